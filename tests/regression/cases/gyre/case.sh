# Forty days of a coarse Atlantic.
program=gyre
arguments=(--cycles 40 --resolution 6 --library-threads 2 --quiet)
tolerances=(--tolerance-relative 1e-9 --tolerance-absolute 1e-11
            # Adaptive steps turn last bits, which compilers and their levels differ in, into more: the tolerance
            # of the steps is 1e-4 m/s, so that a degree, some 1e5 m, may differ in its ninth digit.
            --column x:1e-7:1e-8 --column y:1e-7:1e-8 --column z:1e-6:1e-6 --column temperature:1e-7:1e-7
            --max-pixel 2 --max-share 0.002 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes --ignore-column located_by_reason
            --ignore-column commits) # when to rebuild is decided by measured times
