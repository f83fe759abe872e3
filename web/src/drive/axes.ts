/** Forward, turn left and sideways to the left, −1…1. */
export interface Axes {
  linear: number;
  angular: number;
  lateral: number;
}

export const CENTRE: Axes = { linear: 0, angular: 0, lateral: 0 };

/** Of the head: left and up, −1…1. */
export interface HeadAxes {
  pan: number;
  tilt: number;
}
