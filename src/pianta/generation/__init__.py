"""Models of building types, and new buildings made from them (thesis, chapter 7)."""
