"""What is written on a sheet: names, legends and dimensions."""
