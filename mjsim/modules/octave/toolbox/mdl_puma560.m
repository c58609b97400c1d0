% MDL_PUMA560  The Puma 560, as puma560.
puma560
