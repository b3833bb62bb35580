import subprocess


def define_domain_parameters(domain):
    """The compiler's and the linker's flags of libinsitu, as pkg-config tells them."""
    def flags(*what):
        return subprocess.check_output(['pkg-config', *what, 'insitu'], text=True).strip()

    domain.compile_cflags = flags('--cflags')
    domain.compile_libs = flags('--libs')
