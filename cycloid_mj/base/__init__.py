"""Common basis of all packages: types, units, errors, names, results, files, processes and the compile cache."""
