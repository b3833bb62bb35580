# The decaying mode in the ring of wedges.
program=heat
arguments=(--cycles 60 --resolution 8 --library-threads 2 --quiet)
tolerances=(--tolerance-relative 1e-9 --tolerance-absolute 1e-11
            --max-pixel 2 --max-share 0.002 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes)
