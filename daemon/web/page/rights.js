// Whether this page may change the bench now, and if not why.
const VIEW_ONLY = "View only: to change something, open the link \u201ccontrol\u201d that ovws-web --control prints.";
let right = "look";
let lack = "Not connected to ovws-web.";
let closed = false;

export const setRight = (given) => (right = given);

/** `reason`: why nothing can be changed yet or any more; empty if it can. */
export const setLack = (reason) => (lack = reason);

/** Why nothing can be changed; empty if it can. */
export const whyNot = () => lack || (right === "control" ? "" : VIEW_ONLY);

export const takeBench = ({ loop }) => (closed = loop.closed);

/** Why nothing can start that the closed loop excludes; empty if it can. */
export const whyLoop = () => (closed ? "Open the loop first." : "");
