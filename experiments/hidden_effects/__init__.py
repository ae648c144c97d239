"""The hidden-effect study: devices with one or two effects that the tool is not told about."""
