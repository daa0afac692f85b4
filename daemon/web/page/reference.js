// Taking a reference: the text of a button that does it, and what it does first.
import * as aberration from "./aberration.js";
import { reasonOf } from "./widgets.js";

/** The button's text, which says so if an introduced aberration is cleared first: the reference would contain it. */
export const takeText = (usual) => (aberration.isIntroduced() ? "Clear aberration and take" : usual);

/** Clears an introduced aberration; resolves to the daemon's reason for an error, empty on success. */
export const clearFirst = async () => (aberration.isIntroduced() ? reasonOf(await aberration.clear()) : "");
