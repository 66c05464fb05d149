"""How common things are: on which furniture, on the floor, and what fills a room further."""

from __future__ import annotations

__all__ = ["BENCH", "DESK", "FLOOR", "GOODS", "HUNG", "MORE", "TOPS", "mix"]

Mix = tuple[tuple[str, float], ...]


def mix(text: str) -> Mix:
    """Kinds and how common each is.

    >>> mix("cup 2 plate 1.5")
    (('cup', 2.0), ('plate', 1.5))
    """
    words = text.split()
    return tuple((kind, float(weight)) for kind, weight in zip(words[::2], words[1::2], strict=True))


DINING = mix(
    "plate 3 glass 3 cup 2 bowl 2 bottle 2 vase 1 flowers 1 food 2 papers 1.5 book 1 "
    "candle_holder 0.7 kitchen_clutter 1 phone 0.7 laptop 0.4 small_box 1 small_toy 0.4 "
    "tray 0.6"
)
LOW_TABLE = mix(
    "book 2.5 books 2 cup 2 glass 1.5 bowl 1.5 papers 2 vase 1 flowers 0.8 small_plant 1 "
    "electronics 1.5 candle_holder 1 food 0.8 tray 1 small_toy 0.6 phone 0.7 bottle 0.8 "
    "small_box 0.8"
)
DISPLAY = mix(
    "frame 3 vase 2 books 2.5 small_plant 2 ornament 3 small_box 2 candle_holder 1.2 "
    "stereo 0.7 bowl 1 papers 1 flowers 1 electronics 0.8 bottle 0.5 book 1"
)
DESK = mix(
    "papers 4 book 2 books 2 cup 1.5 office_clutter 4 phone 1 small_plant 0.7 frame 0.7 "
    "electronics 1 bottle 0.7 small_box 1 printer 0.3 glass 0.5 ornament 0.5"
)
KITCHEN = mix(
    "bottle 2.5 appliance 2.5 pot 1.5 kitchen_clutter 3.5 bowl 1.5 food 2 cup 2 plate 1.5 "
    "glass 1.5 can 1.5 microwave 0.5 small_plant 0.5 papers 0.5 tray 0.8 towel 0.7 "
    "vase 0.3 small_box 0.7"
)
BATH = mix(
    "bath_clutter 7 towel 2 cup 1 bottle 3 small_plant 0.6 small_box 0.8 candle_holder 0.5 clothes 0.4"
)
NIGHT = mix(
    "book 2 books 1 glass 1 phone 1.5 frame 1 bottle 0.6 papers 0.7 small_plant 0.6 "
    "small_box 1 cup 1 electronics 0.7"
)
BED = mix("clothes 3 cushion 3 blanket 2 book 1 laptop 0.6 small_toy 0.8 papers 0.4 towel 0.6")
SEAT = mix("cushion 3 blanket 1.5 book 0.7 clothes 0.8 papers 0.6 small_toy 0.4 electronics 0.4")
BENCH = mix("tool 6 can 3 small_box 3 bottle 1.5 papers 1 cup 0.6 goods 1 electronics 1 appliance 0.3")
GOODS = mix(
    "goods 5 small_box 3 books 1 vase 1 clothes 1.5 bowl 0.7 ornament 1 can 1 bottle 1 small_plant 0.5"
)
SHELF = mix(
    "books 4 book 1 ornament 2 vase 1.5 frame 1.5 small_box 2.5 small_plant 1 bowl 1 "
    "papers 1 electronics 0.6 small_toy 0.8 bottle 0.5"
)

TOPS: dict[str, tuple[Mix, float]] = {
    "table": (DINING, 6.0),
    "round_table": (DINING, 6.5),
    "coffee_table": (LOW_TABLE, 8.5),
    "side_table": (LOW_TABLE, 16.0),
    "ottoman": (LOW_TABLE, 0.0),
    "nightstand": (NIGHT, 17.0),
    "desk": (DESK, 9.0),
    "console": (DISPLAY, 13.0),
    "sideboard": (DISPLAY, 11.0),
    "dresser": (DISPLAY, 10.0),
    "low_shelf": (DISPLAY, 11.0),
    "tv_stand": (DISPLAY, 7.0),
    "filing_cabinet": (DESK, 11.0),
    "drawer_unit": (DESK, 12.0),
    "shelf": (SHELF, 15.0),
    "wall_shelf": (SHELF, 16.0),
    "display_cabinet": (SHELF, 6.0),
    "cabinet": (SHELF, 6.0),
    "piano": (DISPLAY, 5.0),
    "kitchen": (KITCHEN, 9.0),
    "island": (KITCHEN, 7.0),
    "washing_machine": (BATH, 9.0),
    "vanity": (BATH, 22.0),
    "basin": (BATH, 22.0),
    "bath": (BATH, 14.0),
    "toilet": (BATH, 10.0),
    "bed": (BED, 1.3),
    "child_bed": (BED, 1.8),
    "sofa": (SEAT, 1.2),
    "armchair": (SEAT, 1.5),
    "workbench": (BENCH, 12.0),
    "tool_cabinet": (BENCH, 14.0),
    "shop_rack": (GOODS, 11.0),
    "display_table": (GOODS, 12.0),
    "counter": (GOODS, 7.0),
    "bar_table": (DINING, 7.0),
    "shoe_rack": (DISPLAY, 8.0),
    "bench": (SEAT, 2.0),
    "pallet": (GOODS, 0.0),
}
"""What stands on a kind of thing, and how many a square metre at the usual density."""

FLOOR: dict[str, tuple[Mix, float]] = {
    "living": (
        mix("basket 2 book_pile 2 bag 0.8 box 1.2 toy 1.5 shoes 1 cable 1 plant 1.5 laundry 0.4 bin 0.5"),
        0.22,
    ),
    "bedroom": (mix("shoes 2 laundry 2 bag 1 basket 1.5 box 1.5 book_pile 1.5 toy 0.8 cable 0.5"), 0.32),
    "office": (mix("box 2.5 bag 1 bin 2 cable 1.5 book_pile 1 crate 0.3"), 0.16),
    "kitchen": (mix("bag 0.8 crate 1 bin 1 box 1 basket 1 shoes 0.4 stool 0.5"), 0.25),
    "bathroom": (mix("basket 1.5 laundry 1.5 bin 1 shoes 0.7 cleaning 0.8 box 0.3"), 0.6),
    "hall": (mix("bag 1 box 1 plant 1.5 bin 0.8 basket 0.5"), 0.05),
    "corridor": (mix("shoes 2.5 bag 1 box 1 basket 1 bin 0.4"), 0.3),
    "shop": (mix("box 2.5 basket 1.5 crate 1 bag 0.7"), 0.1),
    "workshop": (mix("box 2.5 crate 1.5 cable 1.5 bin 0.7 bag 0.6"), 0.18),
    "empty": (mix("box 2 cable 1"), 0.02),
}
"""What lies about on the floor, and how many a square metre."""


_AT_HOME = mix("picture 6 wall_shelf 1.3 mirror 0.8 clock 0.5 board 0.3")
_AT_WORK = mix("picture 4 board 1.5 wall_shelf 1 clock 0.5 sign 0.7 mirror 0.2")
HUNG: dict[str, tuple[Mix, float]] = {
    "living": (_AT_HOME, 0.36),
    "bedroom": (_AT_HOME, 0.36),
    "kitchen": (mix("wall_shelf 3 picture 2.5 clock 0.5 board 0.6 hooks 0.6 towel_rail 0.5"), 0.24),
    "bathroom": (mix("towel_rail 2 wall_shelf 2 picture 1.2 hooks 1 mirror 0.4 wall_cabinet 0.6"), 0.35),
    "corridor": (mix("picture 5 hooks 1 mirror 0.8 wall_shelf 0.5 board 0.3 clock 0.3"), 0.25),
    "office": (_AT_WORK, 0.2),
    "hall": (_AT_WORK, 0.12),
    "shop": (_AT_WORK, 0.14),
    "workshop": (mix("board 1 wall_shelf 2 sign 1.5 picture 1.5 tool_board 1.5 clock 0.4"), 0.16),
    "empty": (_AT_HOME, 0.02),
}
"""What hangs on walls, and how many a metre of wall."""


MORE: dict[str, tuple[Mix, float, float]] = {
    "living": (
        mix(
            "shelf 3 sideboard 2 armchair 2 low_shelf 2 cabinet 2 plant 2 display_cabinet 1 "
            "chair 1 dresser 1 side_table 1 ottoman 1 basket 1"
        ),
        0.36,
        0.2,
    ),
    "bedroom": (
        mix(
            "wardrobe 2 dresser 2 shelf 2 low_shelf 2 chair 1 armchair 1 cabinet 1 hamper 1 "
            "basket 1 plant 1 drawer_unit 1 box 1"
        ),
        0.46,
        0.05,
    ),
    "office": (
        mix(
            "shelf 3 filing_cabinet 3 cabinet 2 desk 2 drawer_unit 2 plant 1.5 chair 2 "
            "low_shelf 1.5 box 1.5 sideboard 1"
        ),
        0.33,
        0.3,
    ),
    "kitchen": (
        mix(
            "shelf 2 cabinet 1.5 sideboard 1.5 low_shelf 1 stool 1 plant 1 bin 1 basket 1 crate 1 "
            "chair 1 side_table 0.5 display_cabinet 0.5"
        ),
        0.37,
        0.1,
    ),
    "hall": (
        mix(
            "armchair 2 sofa 1.5 plant 2 round_table 1.5 display_table 1.5 shelf 2 bench 1.5 "
            "sideboard 1 cabinet 1 chair 1.5 coffee_table 1 screen_divider 0.4 box 0.5"
        ),
        0.17,
        0.55,
    ),
    "shop": (
        mix(
            "shop_rack 4 display_table 3 shelf 2 clothes_rack 1.5 display_cabinet 1 box 1.5 "
            "crate 1 pallet 0.7 plant 0.7 basket 1"
        ),
        0.32,
        0.45,
    ),
    "workshop": (
        mix(
            "shop_rack 3 workbench 2 machine 2 tool_cabinet 2 crate 2 pallet 1.5 box 2 cabinet 1 "
            "barrel 1 locker 0.7 table 1 shelf 1 bicycle 0.3"
        ),
        0.31,
        0.3,
    ),
    "corridor": (mix("low_shelf 1 shoe_rack 1 plant 1 bench 1 chair 1 box 1 basket 1 console 1"), 0.16, 0.0),
}
"""What fills a space further, to which share of its floor, and how much of that away from the walls."""
