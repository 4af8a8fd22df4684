from wires import wires as wires
