"""How the gallery shows the examples: run as from the command line, with the figures that they write to files."""

import shutil
from pathlib import Path

from sphinx_gallery.scrapers import figure_rst

FOLDER = Path(__file__).parent / "_build" / "figures"

#: From what everybody knows to what is special; those that are not named here come last.
ORDER = (
    "pendulum",
    "double_pendulum",
    "four_bar",
    "slider_crank",
    "flying_spaghetti",
    "falling_chain",
    "cantilever_modes",
    "truss_bridge",
    "spring_lattice",
    "wave_absorber",
    "buckling_column",
    "snap_through_arch",
    "rotating_blade",
    "dc_motor_arm",
    "matrices_in_a_loop",
    "duffing",
    "accuracy_and_time",
    "reduced_four_bar",
    "standalone_four_bar",
)


class Order:
    """Sort files of examples.

    Parameters
    ----------
    src_dir : str
        Folder of the examples.
    """

    def __init__(self, src_dir):
        self.known = {f"{name}.py": i for i, name in enumerate(ORDER)}

    def __call__(self, filename):
        """Place in the gallery."""
        return self.known.get(filename, len(ORDER)), filename


def arguments(gallery_conf, script_vars):
    """Arguments on the command line: where to write figures."""
    return ["--out", str(_folder(script_vars["src_file"]))]


def scrape(block, block_vars, gallery_conf):
    """Move the figures that an example has written to the gallery; return the lines that show them."""
    images = []
    folder = _folder(block_vars["src_file"])
    for path in sorted(folder.glob("*.png"), key=lambda found: found.stat().st_mtime_ns):
        image = next(block_vars["image_path_iterator"])
        shutil.move(path, image)
        images.append(image)
    return figure_rst(images, gallery_conf["src_dir"])


def _folder(example):
    return FOLDER / Path(example).stem
