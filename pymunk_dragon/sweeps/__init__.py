"""Parameter sweeps: a quantity of marches at many points of one or more axes."""
