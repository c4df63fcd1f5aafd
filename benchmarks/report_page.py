# SPDX-License-Identifier: BSD-3-Clause
"""Opening time, size and frames per second of a report, and pictures of it, in headless Chromium.

python benchmarks/report_page.py FOLDER [--pictures NAME]

FOLDER is that of a run with a report. The browser draws without a graphics card (SwiftShader), so
the frames per second are a lower bound. They are limited by the pixels drawn, each as often as soil
overlaps there, and by the triangles: both are printed. ``--pictures docs/gallery/report_2d`` saves
the page as seen on a desktop, dark, and on a phone, as report_2d.png, report_2d_dark.png,
report_2d_phone.png; docs/gallery has report_3d.png, report_3d_dark.png, report_3d_phone.png, too.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from report_browser import complaints, opened

NEXT = """
const scene = Tilth.view.scene, context = scene.renderer.getContext(), pixel = new Uint8Array(4);
const next = async () => {
  await new Promise(requestAnimationFrame);
  context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, pixel);  // waits for the end
};
"""
TURN = f"""{NEXT}
const start = performance.now(), before = scene.frames;
for (let count = 0; performance.now() - start < 5000; count++) {{
  if (scene.plane) scene.camera.zoom = 1 + 0.2 * Math.sin(0.1 * count);
  else scene.camera.position.applyAxisAngle(scene.camera.up, 0.05);
  scene.camera.lookAt(0, 0, 0); scene.camera.updateProjectionMatrix();
  scene.move(); await next();
}}
const frames = scene.frames - before, rate = 1000 * frames / (performance.now() - start);
scene.look(); scene.resize();
return [rate, frames];
"""
SLIDE = f"""{NEXT}
const view = Tilth.view, start = performance.now(), all = view.body.frames.length;
let count = 0;
for (; performance.now() - start < 5000; count++) {{
  await view.show(count % all, true); await next();
}}
return 1000 * count / (performance.now() - start);
"""
LIMIT = """
const scene = Tilth.view.scene, { canvas, camera } = scene, place = new THREE.Vector3();
scene.render();
let area = 0, count = 0;
for (const { visible, geometry } of scene.ground.children) {
  if (!visible || !geometry.index) continue;
  const at = geometry.attributes.position.array, index = geometry.index.array;
  for (let k = 0; k < index.length; k += 3) {
    const [[ax, ay], [bx, by], [cx, cy]] = [0, 1, 2].map(
      (corner) => place.fromArray(at, 3 * index[k + corner]).project(camera).toArray());
    area += Math.abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)) / 8; count += 1;
  }
}
return [canvas.width * canvas.height, scene.pixels.x * scene.pixels.y, area, count];
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pictures", type=Path, help="beginning of the names of the pictures")
    given = parser.parse_args()
    page = given.folder / "report.html"
    with opened(page) as driver:
        driver.set_script_timeout(300)
        begin = time.perf_counter()
        driver.refresh()
        while not driver.execute_script("return typeof Tilth === 'object' && Tilth.ready === true"):
            time.sleep(0.02)
        opening = time.perf_counter() - begin
        frame = driver.execute_script("return Tilth.data.body.frames.at(-1)")
        outputs = driver.execute_script("return Tilth.data.body.frames.length")
        notes = driver.execute_script("return Tilth.data.body.notes.join(' ')")
        print(f"{page.stat().st_size / 1e6:.2f} MB, opened in {opening:.2f} s")
        print(f"{frame['count']:,} of {frame['total']:,} points, {outputs} outputs. {notes}")
        pixels, moving, overlap, triangles = driver.execute_script(LIMIT)
        print(f"{pixels:,} pixels at rest, {moving:,} in slow movement, each drawn {overlap:.2f}")
        print(f"times on average, {triangles:,} triangles")
        before = processor_time(driver)
        rate, frames = driver.execute_script(TURN)
        each = 1000 * (processor_time(driver) - before) / frames
        print(f"{rate:.1f} frames per second turned or enlarged, load {load()}")
        print(f"{each:.0f} ms of processor time a frame, of all processes of the browser")
        print(f"{driver.execute_script(SLIDE):.1f} outputs per second on the slider")
        print("console:", complaints(driver) or "silent")
    if given.pictures:
        for suffix, size, dark in (
            ("", (1200, 1800), False),
            ("_dark", (1200, 1800), True),
            ("_phone", (390, 1800), False),
        ):
            with opened(page, size, dark) as driver:
                save(driver, Path(f"{given.pictures}{suffix}.png"))


def load() -> str:
    """Returns how many processes compute on how many cores, on average of the last minute."""
    return f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"


def processor_time(driver: Any) -> float:
    """Returns the processor time that the browser has taken [s], whatever else runs."""
    parent, used = {}, {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        number = int(path.parent.name)
        parent[number] = int(fields[1])
        used[number] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    root, total = driver.service.process.pid, 0.0
    for number, seconds in used.items():
        above = number
        while above > 1 and above != root:
            above = parent.get(above, 0)
        total += seconds if above == root else 0.0
    return total


def save(driver: Any, path: Path) -> None:
    """Saves what is visible, with at most 256 colours."""
    from io import BytesIO

    from PIL import Image

    time.sleep(1.0)  # layout and the first frames
    picture = Image.open(BytesIO(driver.get_screenshot_as_png())).convert("RGB")
    colours = picture.quantize(256, method=Image.Quantize.MAXCOVERAGE, kmeans=3)
    few = picture.quantize(palette=colours, dither=Image.Dither.FLOYDSTEINBERG)
    few.save(path, optimize=True)


if __name__ == "__main__":
    main()
