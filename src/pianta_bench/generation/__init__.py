"""Chapter 7: generated buildings."""
