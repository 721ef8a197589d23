"""The default method: narrow passages and wall lines together (thesis, chapter 9)."""
