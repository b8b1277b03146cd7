"""One sequence of bytes as several files of limited size, replaced as a whole.

A set is NAME.GENERATION.KofN, its first piece headed by length and SHA-256 of all bytes. Whoever dies while writing leaves the
set before it, which is taken away only when the new one is whole.
"""
import hashlib
import re

MOST_BYTES = 15 * 2**20  # of a piece
HEAD_BYTES = 96


def sets(folder, name):
    """Generation -> its pieces in order, of the sets that have all of theirs; newest first."""
    found = {}
    for file in folder.glob(f"{name}.*of*"):
        match = re.fullmatch(rf"{re.escape(name)}\.(\d+)\.(\d+)of(\d+)", file.name)
        if match:
            generation, number, count = (int(value) for value in match.groups())
            found.setdefault((generation, count), {})[number] = file
    whole = {generation: [pieces[n] for n in range(1, count + 1)] for (generation, count), pieces in found.items()
             if sorted(pieces) == list(range(1, count + 1))}
    return dict(sorted(whole.items(), reverse=True))


def write(folder, name, generation, content, most=MOST_BYTES):
    folder.mkdir(parents=True, exist_ok=True)
    head = f"{len(content)} {hashlib.sha256(content).hexdigest()}".ljust(HEAD_BYTES - 1) + "\n"
    content = head.encode() + content
    count = -(-len(content) // most)
    before = [file for file in folder.glob(f"{name}.*") if not file.name.startswith(f"{name}.{generation}.")]
    for number in range(count, 0, -1):
        file = folder / f"{name}.{generation}.{number}of{count}"
        aside = file.with_name(file.name + ".partial")
        aside.write_bytes(content[(number - 1) * most:number * most])
        aside.replace(file)
    for file in before:
        file.unlink(missing_ok=True)


def read(folder, name):
    """(generation, bytes) of the newest set that is whole and unchanged; nothing where there is none."""
    for generation, files in sets(folder, name).items():
        content = b"".join(file.read_bytes() for file in files)
        head, content = content[:HEAD_BYTES].decode("ascii", "replace").split(), content[HEAD_BYTES:]
        if head == [str(len(content)), hashlib.sha256(content).hexdigest()]:
            return generation, content
        print(f"{files[0]}: cut short or changed; an older checkpoint is looked for", flush=True)
    return None
