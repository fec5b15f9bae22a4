"""Materials from measured spectra of permittivity and conductivity."""
