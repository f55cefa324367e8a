#!/usr/bin/env python3
"""Draws the maps that ship with parloc from metric boxes, discs and wall segments.

Run once, from any folder, with numpy; the output under maps/ is committed:

    python3 tools/studies/make_maps.py

Every floor plan is drawn at 1 cm (maps/fine/*.png, what the simulator casts against) and reduced to 5 cm
(maps/*.pgm, what a filter gets). All geometry lies off the 5 cm grid on purpose, so that the 5 cm map is as wrong as
a good real map: its walls are up to half a cell off. A 5 cm cell is occupied when at least 13 of its 25 fine cells
are, which moves walls neither inwards nor outwards on average.
"""

import math
import random
from itertools import pairwise

import numpy as np
from grids import FREE, OCCUPIED, UNKNOWN, grid_of, write_map
from measuring import ROOT

FINE_M, COARSE_M, RATIO = 0.01, 0.05, 5


def turned(x, y, angle_deg):
    """Where (u, v) of something at (x, y) lies that is turned counter-clockwise."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return lambda u, v: (x + c * u - s * v, y + s * u + c * v)


class Floor:
    """A floor plan of `width_m` x `height_m` whose lower-left corner is at `origin` in the map frame, in 1 cm cells."""

    def __init__(self, name, width_m, height_m, origin=(0.0, 0.0), fill=FREE):
        self.name, self.origin = name, origin
        self.cells = np.full((round(height_m / FINE_M), round(width_m / FINE_M)), fill, np.uint8)  # row 0 at the bottom

    def around(self, points):
        """The points in cells from the corner, the cells around them, and the columns and rows of those cells' centres."""
        points = (np.array(points) - self.origin) / FINE_M
        (left, low), (right, high) = (np.maximum(side, 0).astype(int) for side in (points.min(0), np.ceil(points.max(0))))
        cells = self.cells[low:high, left:right]
        rows, columns = np.ogrid[:cells.shape[0], :cells.shape[1]]
        return points, cells, left + columns + 0.5, low + rows + 0.5

    def polygon(self, corners, value=OCCUPIED):
        """Fills a convex polygon, corners counter-clockwise: the fine cells whose centre lies inside it."""
        points, cells, x, y = self.around(corners)
        sides = zip(points, np.roll(points, -1, 0), strict=True)
        cells[np.logical_and.reduce([(bx - ax) * (y - ay) >= (by - ay) * (x - ax) for (ax, ay), (bx, by) in sides])] = value

    def rect(self, x0, y0, x1, y1, value=OCCUPIED):
        self.polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], value)

    def box(self, x, y, length, depth, angle_deg=0.0):
        """A box around its centre (x, y), turned counter-clockwise."""
        at, u, v = turned(x, y, angle_deg), length / 2, depth / 2
        self.polygon([at(-u, -v), at(u, -v), at(u, v), at(-u, v)])

    def wall(self, x0, y0, x1, y1, thickness=0.12):
        """A straight wall along the segment, with square ends."""
        angle = math.degrees(math.atan2(y1 - y0, x1 - x0))
        self.box((x0 + x1) / 2, (y0 + y1) / 2, math.hypot(x1 - x0, y1 - y0) + thickness, thickness, angle)

    def disc(self, x, y, radius):
        (low, high), cells, columns, rows = self.around([(x - radius, y - radius), (x + radius, y + radius)])
        middle = (low + high) / 2
        cells[np.hypot(columns - middle[0], rows - middle[1]) <= radius / FINE_M] = OCCUPIED

    def coarse(self):
        """5 cm cells, row 0 at the bottom. Unknown only where more than half of the cell is."""
        height, width = self.cells.shape
        blocks = self.cells.reshape(height // RATIO, RATIO, width // RATIO, RATIO)
        mostly = {kind: (blocks == kind).mean((1, 3)) > 0.5 for kind in (OCCUPIED, UNKNOWN)}
        return np.select(list(mostly.values()), list(mostly), FREE).astype(np.uint8)

    def save(self, image=".pgm"):
        write_map(ROOT / f"maps/fine/{self.name}.yaml", grid_of(self.cells, FINE_M, self.origin), ".png")
        save_coarse(self.name, self.coarse(), self.origin, image)


def save_coarse(name, cells, origin=(0.0, 0.0), image=".pgm"):
    grid = grid_of(cells, COARSE_M, origin)
    write_map(ROOT / f"maps/{name}.yaml", grid, image)
    occupied, free_m2 = grid.cells.count(OCCUPIED) / len(grid.cells), grid.cells.count(FREE) * COARSE_M ** 2
    print(f"{name}: {grid.width} x {grid.height} cells, {100 * occupied:.2f} % occupied, {free_m2:.0f} m2 free")


# ---- the hall: 20 x 10 m --------------------------------------------------------------------------------------------
def hall(name="hall"):
    floor = Floor(name, 20.0, 10.0)
    floor.rect(0.0, 0.0, 0.068, 10.0)
    floor.rect(19.934, 0.0, 20.0, 10.0)
    floor.rect(0.0, 0.0, 20.0, 0.057)
    floor.rect(0.0, 9.938, 20.0, 10.0)
    return floor


def hall_obstacles():
    """The hall with partition walls, pillars and boxes; nowhere symmetric, so that a scan says where it was taken."""
    floor = hall("hall_obstacles")
    floor.wall(5.327, 6.412, 5.327, 9.95)          # partition walls
    floor.wall(9.884, 0.05, 9.884, 2.673)
    floor.wall(14.618, 5.236, 17.437, 5.236)
    floor.wall(14.618, 5.236, 14.618, 3.861)
    floor.wall(10.713, 8.527, 10.713, 9.95)
    floor.box(3.273, 3.614, 0.43, 0.43)            # pillars
    floor.box(7.432, 7.283, 0.43, 0.43)
    floor.disc(12.387, 2.036, 0.264)
    floor.disc(17.118, 2.561, 0.264)
    floor.disc(9.962, 6.377, 0.213)
    floor.box(0.334, 7.128, 0.53, 0.93)            # boxes, shelves, a pallet
    floor.box(2.337, 9.637, 1.22, 0.43)
    floor.box(5.614, 4.138, 0.67, 0.43, 31.0)
    floor.box(19.463, 8.724, 0.87, 0.47, 90.0)
    floor.box(15.762, 8.963, 0.73, 0.52, -18.0)
    floor.box(18.862, 0.383, 1.43, 0.41)
    floor.box(7.637, 0.402, 0.93, 0.43)
    return floor


# ---- the office: 52.4 x 31.7 m --------------------------------------------------------------------------------------
THIN, THICK = 0.11, 0.237
DOOR_M, MARGIN_M = 0.96, 0.8


def building(name, width, height):
    """An outer wall all around, beyond which nothing is known."""
    floor = Floor(name, width + 2 * MARGIN_M, height + 2 * MARGIN_M, origin=(-MARGIN_M, -MARGIN_M), fill=UNKNOWN)
    floor.rect(0.0, 0.0, width, height)
    floor.rect(THICK, THICK, width - THICK, height - THICK, FREE)
    return floor


def wall_with_doors(floor, fixed, start, end, doors, vertical):
    """An axis-parallel wall at x (vertical) or y = `fixed`, with door openings centred at `doors`."""
    edges = [start] + [e for d in sorted(doors) for e in (d - DOOR_M / 2, d + DOOR_M / 2)] + [end]
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        if vertical:
            floor.rect(fixed - THIN / 2, a, fixed + THIN / 2, b)
        else:
            floor.rect(a, fixed - THIN / 2, b, fixed + THIN / 2)


def door_leaf(floor, hinge_x, hinge_y, angle_deg):
    """An open door: a leaf 6 cm thick from its hinge."""
    floor.box(*turned(hinge_x, hinge_y, angle_deg)(0.45, 0.0), 0.90, 0.06, angle_deg)


def desk(floor, x, y, angle_deg=0.0):
    """A desk as a LiDAR at knee height sees it: two legs on one side, a drawer unit on the other, a chair's base."""
    at = turned(x, y, angle_deg)
    for u, v in ((-0.73, -0.32), (-0.73, 0.32)):
        floor.box(*at(u, v), 0.09, 0.09, angle_deg)
    floor.box(*at(0.54, 0.03), 0.43, 0.61, angle_deg)
    floor.disc(*at(-0.13, -0.63), 0.19)


def table(floor, x, y, length, depth, angle_deg=0.0, chairs=0):
    """A meeting table: four legs, and chairs' bases along both long sides."""
    at = turned(x, y, angle_deg)
    for u in (-length / 2 + 0.12, length / 2 - 0.12):
        for v in (-depth / 2 + 0.1, depth / 2 - 0.1):
            floor.box(*at(u, v), 0.1, 0.1, angle_deg)
    for k in range(chairs):
        u = (k + 0.5) * length / chairs - length / 2
        for v in (-depth / 2 - 0.28, depth / 2 + 0.28):
            floor.disc(*at(u, v), 0.17)


def south_rooms(floor):
    """Nine rooms along the south front, y 0.24 to 7.28; the first five are alike but for their furniture."""
    walls = [4.913, 9.587, 14.263, 18.937, 23.614, 30.367, 35.041, 43.286]
    for x in walls:
        floor.rect(x - THIN / 2, 0.2, x + THIN / 2, 7.33)
    alike = list(pairwise([0.237, *walls[:5]]))
    doors = [left + 1.17 for left, _ in alike] + [26.437, 29.118, 32.663, 37.482, 41.538, 45.263, 50.417]
    wall_with_doors(floor, 7.334, 0.2, 52.2, doors, vertical=False)
    for left, right in alike:
        desk(floor, right - 1.347, 1.263, 180.0)
        desk(floor, right - 1.347, 4.462)
        floor.box(left + 0.33, 3.217, 0.44, 1.68)
        door_leaf(floor, left + 1.17 - DOOR_M / 2, 7.28, -84.0)
    floor.box(2.437, 0.487, 0.83, 0.43)             # what tells the alike rooms apart
    floor.disc(7.218, 3.632, 0.22)
    floor.box(12.163, 0.523, 1.27, 0.47)
    floor.box(16.347, 2.283, 0.62, 0.62, 24.0)
    table(floor, 26.983, 3.687, 3.83, 1.42, 0.0, chairs=4)      # meeting room
    floor.box(24.017, 5.362, 0.46, 1.23)
    floor.box(32.687, 0.513, 2.83, 0.46)                        # store
    floor.box(31.013, 3.162, 0.52, 2.37)
    floor.box(34.472, 3.887, 0.52, 2.63)
    table(floor, 38.213, 2.163, 1.43, 1.43, 12.0, chairs=2)     # canteen
    table(floor, 41.162, 3.862, 1.43, 1.43, -9.0, chairs=2)
    table(floor, 37.338, 4.937, 1.43, 1.43, 31.0, chairs=2)
    floor.box(39.463, 0.537, 4.37, 0.58)
    floor.box(47.737, 3.163, 3.27, 1.63)                        # workshop: machines
    floor.box(50.863, 1.387, 1.28, 1.13, 8.0)
    floor.disc(45.017, 5.238, 0.46)
    floor.box(44.237, 0.612, 1.42, 0.72)


def north_rooms(floor):
    """Seven rooms along the north front, y 24.2 to 31.46."""
    walls = [7.382, 14.527, 21.673, 27.438, 36.814, 45.263]
    for x in walls:
        floor.rect(x - THIN / 2, 24.13, x + THIN / 2, 31.5)
    doors = [3.187, 12.963, 16.113, 20.087, 24.562, 29.263, 35.137, 39.412, 48.638]
    wall_with_doors(floor, 24.187, 0.2, 52.2, doors, vertical=False)
    for x in (1.513, 3.838, 6.163):                             # open rooms of desks
        desk(floor, x, 30.463, 180.0)
        desk(floor, x - 0.127, 26.937)
    for x in (8.863, 11.237):
        desk(floor, x, 30.512, 180.0)
    floor.box(13.912, 28.637, 0.83, 2.23)
    floor.box(7.737, 26.838, 0.47, 1.87)
    for row, y in enumerate((25.962, 28.163, 30.362)):          # seminar room
        for column in range(3):
            table(floor, 16.063 + 2.037 * column + 0.083 * row, y, 1.27, 0.63)
    floor.box(24.613, 30.987, 3.46, 0.62)                       # kitchen
    table(floor, 24.587, 28.012, 1.83, 0.87, 90.0, chairs=3)
    floor.box(21.987, 25.662, 0.48, 0.73)
    table(floor, 32.138, 28.113, 5.23, 1.63, 0.0, chairs=6)     # board room
    floor.box(36.437, 30.587, 0.57, 1.26)
    floor.disc(27.913, 30.962, 0.26)
    for x in (38.563, 41.213, 43.862):
        desk(floor, x, 30.437, 180.0)
    floor.box(44.213, 26.113, 1.62, 0.83, 90.0)
    floor.box(48.863, 28.487, 2.83, 1.23, 37.0)                 # lab
    floor.box(51.587, 30.263, 0.92, 1.87)
    floor.box(46.463, 31.112, 1.87, 0.58)


def core(floor):
    """Between the corridors: two west rooms, an open-plan area, stairs and lifts, meeting boxes, two east halls."""
    wall_with_doors(floor, 8.537, 9.66, 21.83, [11.387, 19.463], vertical=True)          # west block
    wall_with_doors(floor, 9.713, 0.2, 8.59, [], vertical=False)
    wall_with_doors(floor, 21.783, 0.2, 8.59, [], vertical=False)
    floor.rect(0.2, 15.362, 8.54, 15.362 + THIN)
    for y in (11.263, 13.637):
        desk(floor, 1.362, y, 90.0)
    floor.box(5.237, 14.962, 2.43, 0.48)
    table(floor, 3.763, 18.512, 2.63, 1.23, 5.0, chairs=3)
    floor.box(0.537, 20.863, 0.58, 1.37)

    wall_with_doors(floor, 10.787, 9.66, 21.83, [15.738], vertical=True)                 # open plan
    wall_with_doors(floor, 9.713, 10.74, 40.87, [13.362, 20.813, 32.937, 38.262], vertical=False)
    wall_with_doors(floor, 21.783, 10.74, 40.87, [16.463, 33.163, 37.838], vertical=False)
    wall_with_doors(floor, 23.362, 9.66, 21.83, [18.937], vertical=True)
    for column in range(4):
        for row, y in enumerate((11.613, 18.062)):
            x = 12.463 + 2.787 * column + 0.063 * row
            desk(floor, x, y)
            desk(floor, x, y + 0.983, 180.0)
    floor.box(14.537, 15.413, 1.83, 0.42)
    floor.box(18.962, 15.662, 0.42, 1.63, 15.0)
    floor.disc(21.763, 14.337, 0.31)
    floor.box(22.462, 20.962, 0.63, 0.72)

    floor.rect(25.063, 11.438, 29.487, 19.913)                                           # lifts and shafts: solid
    floor.rect(25.283, 11.662, 29.263, 19.687, UNKNOWN)
    wall_with_doors(floor, 31.138, 9.66, 21.83, [11.013], vertical=True)
    floor.rect(31.138, 15.713, 40.87, 15.713 + THIN)                                     # meeting boxes
    floor.rect(35.862, 15.713, 35.862 + THIN, 21.83)
    floor.rect(35.562, 9.66, 35.562 + THIN, 15.76)
    table(floor, 33.487, 19.037, 1.87, 1.13, 0.0, chairs=2)
    table(floor, 38.413, 18.362, 2.43, 1.13, 90.0, chairs=3)
    floor.box(33.463, 13.637, 1.87, 0.83)
    floor.box(32.112, 15.338, 1.43, 0.47)
    floor.box(39.913, 12.962, 0.47, 2.63)
    floor.disc(36.338, 14.962, 0.24)
    floor.box(23.963, 20.887, 0.83, 0.43)

    wall_with_doors(floor, 40.813, 9.66, 21.83, [], vertical=True)                       # east halls
    wall_with_doors(floor, 43.263, 9.66, 21.83, [12.637, 19.863], vertical=True)
    wall_with_doors(floor, 9.713, 43.21, 52.2, [], vertical=False)
    wall_with_doors(floor, 21.783, 43.21, 52.2, [], vertical=False)
    floor.rect(43.21, 16.537, 52.2, 16.537 + THIN)
    for y in (10.613, 12.987, 15.362):
        floor.box(48.863, y, 4.13, 0.62)
    floor.box(47.763, 19.137, 1.43, 1.43, 45.0)
    floor.box(51.162, 17.463, 1.37, 0.87)
    floor.box(50.413, 21.337, 2.43, 0.53)


def corridor_things(floor):
    floor.box(7.737, 7.637, 0.83, 0.47)             # cabinets, a copier, plants, a bench
    floor.box(22.137, 9.437, 1.63, 0.43)
    floor.box(35.862, 7.613, 1.23, 0.42)
    floor.disc(0.613, 8.937, 0.24)
    floor.disc(51.787, 7.763, 0.24)
    floor.box(18.037, 23.863, 1.87, 0.47)
    floor.box(27.362, 22.087, 0.73, 0.48)
    floor.box(44.087, 23.887, 1.43, 0.43)
    floor.disc(0.587, 22.163, 0.23)
    floor.box(9.013, 16.937, 0.43, 1.21)
    floor.box(42.962, 15.113, 0.42, 1.37)
    floor.disc(51.763, 23.762, 0.22)


def office():
    floor = building("office", 52.4, 31.7)
    south_rooms(floor)
    north_rooms(floor)
    core(floor)
    corridor_things(floor)
    return floor


# ---- the works: 132 x 92 m of random rooms ----------------------------------------------------------------------------
def furniture(floor, draw, left, low, right, high):
    """Desks, boxes and pillars at random places of a room, clear of its walls."""
    for _ in range(int(1 + (right - left) * (high - low) / 11)):
        x, y = left + 1.1 + draw() * (right - left - 2.2), low + 1.2 + draw() * (high - low - 2.4)
        kind = draw()
        if kind < 0.35:
            desk(floor, x, y, 90.0 * int(4 * draw()))
        elif kind < 0.8:
            floor.box(x, y, 0.4 + 1.2 * draw(), 0.4 + 0.5 * draw(), 90.0 * draw() if kind < 0.5 else 90.0 * int(2 * draw()))
        else:
            floor.disc(x, y, 0.15 + 0.25 * draw())


def row_of_rooms(floor, draw, left, right, low, high, door_y):
    """Rooms side by side, walls between them, a door each in the wall at door_y."""
    x, doors = left, []
    while x < right:
        width = 3.3 + 6.7 * draw()
        end = right if right - x - width < 3.3 else x + width
        doors.append(x + 0.9 + draw() * (end - x - 1.8))
        furniture(floor, draw, x, low, end, high)
        if end < right:
            floor.rect(end - THIN / 2, low, end + THIN / 2, high)
        x = end
    wall_with_doors(floor, door_y, left - THIN / 2, right + THIN / 2, doors, vertical=False)


def works():
    """More than 10,000 m2: five corridors, two cross corridors, and rooms of random widths on both sides."""
    width, height, draw = 132.0, 92.4, random.Random(5).random
    floor = building("works", width, height)
    for row in range(5):                                        # a corridor between two rows of rooms each
        low = THICK + 18.4 * row
        deep, corridor = 6.3 + 1.9 * draw(), 1.9 + 0.9 * draw()
        top = low + 18.33 if row < 4 else height - THICK
        for left, right in ((THICK, 42.013), (44.317, 88.163), (90.382, width - THICK)):
            row_of_rooms(floor, draw, left, right, low, low + deep, low + deep)
            row_of_rooms(floor, draw, left, right, low + deep + corridor, top, low + deep + corridor)
            for x in (left, right):                             # room walls along the cross corridors
                if THICK < x < width - THICK:
                    floor.rect(x - THIN / 2, low, x + THIN / 2, low + deep)
                    floor.rect(x - THIN / 2, low + deep + corridor, x + THIN / 2, top)
            if row < 4:
                floor.rect(left, top, right, top + THIN)
        for _ in range(9):
            floor.box(1.0 + draw() * (width - 2.0), low + deep + 0.3, 0.5 + draw(), 0.4)
    return floor


def empty():
    """The worst case of Paz et al. 2012: no ray ends within its range. 800 x 600 free cells of 5 cm."""
    save_coarse("empty", np.full((600, 800), FREE, np.uint8))


if __name__ == "__main__":
    for plan in (hall(), hall_obstacles(), office()):
        plan.save()
    works().save(image=".png")
    empty()
