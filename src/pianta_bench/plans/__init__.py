"""Section 3.3: pictures of plans."""
