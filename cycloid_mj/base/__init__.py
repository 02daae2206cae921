"""What every room stands on: types, units, errors, names, results, files, processes and the compile cache."""
