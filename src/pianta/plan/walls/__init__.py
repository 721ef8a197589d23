"""Walls of a plan: a network segments the sheet, a minimum cut finds the inside, and both become a map."""
