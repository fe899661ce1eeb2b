"""``phblocks check``: the report, conflicts with repairs that mend, effects kept and left out."""

import phblocks as ph


def test_a_causal_diagram(phblocks):
    said = phblocks("check stone.py")
    assert said.code == 0 and said.err == ""
    assert "stone.centre.translation  velocity  force  outside 'push'" in said.out
    assert "compiled: 2 states, inputs push.x, push.y" in said.out


def test_the_same_for_programs(phblocks):
    data = phblocks("check rod.py --json").data
    assert data["command"] == "check" and data["ok"] and data["causal"] and data["conflicts"] == []
    by_port = {a["port"]: a for a in data["assignments"]}
    assert by_port["rod.start.translation"]["gives"] == "force"  # the ground gives velocity
    assert by_port["rod.start.translation"]["joined_to"] == ["ground.anchor.translation"]
    phblocks("export rod.py --to rod.json")
    system = ph.load("rod.json").compile()
    assert data["states"] == system.n
    kept = sum(effect["status"] == "kept" for effect in data["effects"])
    assert kept == len(system.effects.select(status="kept")) > 5


def test_what_is_left_out_is_listed_with_its_reason(phblocks, folder):
    (folder / "column.py").write_text(
        "import phblocks as ph\n"
        "diagram = ph.Diagram('column')\n"
        "s = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)\n"
        "rod = diagram.add(ph.Beam('rod', s, (0.0, 0.0), (1.0, 0.0), elements=3))\n"
        "diagram.weld(rod.start, diagram.ground)\n"
        "force = diagram.add(ph.Force('force', (1.0, 0.0), follows=True))\n"
        "diagram.connect(force.port, rod.end.translation)\n"
    )
    data = phblocks("check column.py --json").data
    pruned = {effect["name"] for effect in data["effects"] if effect["status"] == "pruned"}
    assert {"bending", "shear"} & pruned or {"M3", "N2"} & pruned  # a rod pulled along its axis does not bend
    text = phblocks("check column.py").out
    assert "pruned" in text and "(diagram)" in text
    assert len(phblocks("check column.py --effects").out.splitlines()) > len(text.splitlines())


def test_a_conflict_has_repairs(phblocks):
    said = phblocks("check bodies.py")
    assert said.code == 1
    assert "conflict: junction [a.tip.translation = b.tip.translation] (pin at bodies.py:7)" in said.out
    assert "repair: " in said.out and said.out.rstrip().endswith("not causal")
    data = phblocks("check bodies.py --json").data
    assert not data["ok"] and data["conflicts"][0]["code"] == "PH304" and "states" not in data
    assert [repair["cost"]["index"] for repair in data["repairs"]] == [0, 2]


def test_a_repair_is_written_and_mends(phblocks):
    said = phblocks("check bodies.py --repair 1 --save mended.json")
    assert said.code == 1 and "repaired diagram in mended.json" in said.out
    after = phblocks("check mended.json --json")
    assert after.code == 0 and len(after.data["constraints"]) == 2  # a pin in the plane


def test_repairs_that_there_are_not(phblocks):
    assert phblocks("check bodies.py --repair 2 --save mended.json").code == 2
    assert phblocks("check stone.py --repair 0 --save mended.json").code == 2
    said = phblocks("check bodies.py --repair 0")
    assert said.code == 2 and "--save" in said.err


def test_a_port_is_explained(phblocks):
    data = phblocks("check rod.py --json --explain rod.start.translation").data
    assert "ground" in data["explanation"]
    assert phblocks("check rod.py --explain rod.middle").code == 2


def test_conflicts_of_a_file_name_its_entries(phblocks):
    assert phblocks("export bodies.py --to bodies.json").code == 0
    assert "(connect at file bodies.json: junctions[0])" in phblocks("check bodies.json").out
