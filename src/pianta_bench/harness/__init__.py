"""What all benches share: records, tables, reports, the command line."""
