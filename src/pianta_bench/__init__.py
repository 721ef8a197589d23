"""The benches of pianta: the tables of the thesis, measured again, and what goes beyond them."""
