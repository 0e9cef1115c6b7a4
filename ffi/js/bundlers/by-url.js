import { createWorld } from "trisap";
import { tell } from "./program.js";

tell(createWorld);
