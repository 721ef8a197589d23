"""Thousands of maps: processes that may crash, a journal of what is done, and one table of all buildings."""
