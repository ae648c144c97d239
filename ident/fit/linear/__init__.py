"""The linear model with which a campaign starts: its starting values, and which one it is."""
