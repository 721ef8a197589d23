"""Sheets: plans as pixels, their ink, and the floors on them."""
