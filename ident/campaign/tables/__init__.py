"""Tables as they lie in files: any format, separator, header and unit, brought to named columns."""
