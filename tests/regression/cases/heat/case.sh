# The decaying mode in the ring of wedges.
program=heat
arguments=(--cycles 60 --resolution 8 --library-threads 2 --quiet)
tolerances=(--tolerance-relative 1e-9 --tolerance-absolute 1e-11
            # Adaptive steps turn last bits, which compilers and their levels differ in, into more: 5e-9 of a
            # line was seen, and 2e-10 of a coordinate near 0, where the absolute bound holds (the ring: radius 1 to 2).
            --column s:1e-7:1e-9 --column x:1e-7:1e-9 --column y:1e-7:1e-9 --column z:1e-7:1e-9
            --max-pixel 2 --max-share 0.002 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes --ignore-column located_by_reason
            --ignore-column commits) # when to rebuild is decided by measured times
