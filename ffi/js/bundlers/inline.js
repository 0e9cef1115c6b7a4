import { createWorld } from "trisap/inline";
import { tell } from "./program.js";

tell(createWorld);
