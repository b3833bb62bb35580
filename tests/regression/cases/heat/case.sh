# The decaying mode in the ring of wedges.
program=heat
arguments=(--cycles 60 --resolution 8 --library-threads 2 --quiet)
tolerances=(--tolerance-relative 1e-9 --tolerance-absolute 1e-11
            # Adaptive steps turn last bits, which compilers and their levels differ in, into more: 5e-9 of a
            # line was seen. Absolute beside a ring of radius 1: a coordinate near 0 has no relative error.
            --column s:1e-7:1e-8 --column x:1e-7:1e-8 --column y:1e-7:1e-8 --column z:1e-7:1e-8
            --max-pixel 2 --max-share 0.002 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes --ignore-column located_by_reason
            --ignore-column commits) # when to rebuild is decided by measured times
