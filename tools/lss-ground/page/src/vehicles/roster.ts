// The vehicles that the page can draw. One that it does not know is shown without a picture.

import {ardito} from "./ardito";
import type {Kind} from "./kind";
import {talaris} from "./talaris";
import {zebro} from "./zebro";

export const roster: Record<string, Kind> = {zebro, ardito, talaris};
