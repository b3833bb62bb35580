# The blast wave on 12^3 cells with costly light: path tracing, shadows, occlusion; images of every kind.
program=sedov
arguments=(--cells 12 --cycles 40 --library-threads 2 --quiet)
# As sedov's. Paths are the same as long as no collision changes sides, which the last digit may bring about in
# few of a million: a pixel then differs by one of its samples.
tolerances=(--tolerance-relative 1e-9 --tolerance-absolute 1e-11
            --max-pixel 2 --max-share 0.01 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes --ignore-column located_by_reason
            --ignore-column commits
            --column R:1e-5:1e-6 --column G:1e-5:1e-6 --column B:1e-5:1e-6 --column Z:1e-5:0) # floats
# On several processes a traced path takes a message a collision: few paths, small images.
thin=(-e 's/samples: 32/samples: 2/' -e 's/size: .*/size: [24, 20]/')
