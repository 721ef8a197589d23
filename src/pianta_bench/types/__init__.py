"""Tables 4.2 to 4.4: types of buildings by their rooms."""
