"""The tables of the thesis, one file per table."""
