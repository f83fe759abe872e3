/** Client of an HBBA console: what REST and the live stream offer, typed. */

export type * from "./records.js";
export { Problem, Unreachable } from "./request.js";
export { type HeldDesire, Robot, type RobotOptions } from "./robot.js";
