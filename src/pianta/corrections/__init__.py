"""What people mend on a floor, as data that holds for every later reading of the building."""
