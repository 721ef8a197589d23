"""The tables of the thesis, one file per table, and what methods cost."""
