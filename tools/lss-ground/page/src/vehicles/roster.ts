// The vehicles that the page can draw. An unknown vehicle is shown without a picture.

import {ardito} from "./ardito";
import type {Kind} from "./kind";
import {talaris} from "./talaris";
import {zebro} from "./zebro";

export const roster: Record<string, Kind> = {zebro, ardito, talaris};
