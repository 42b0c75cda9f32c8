# cmake -DSOURCE=... -DOUT=... -P: the commit that is being built, as a header that changes only with it.
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND git -C ${SOURCE} rev-parse --short HEAD OUTPUT_VARIABLE commit
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${OUT} CONTENT "#define ATLAS_COMMIT \"@commit@\"\n" @ONLY)
