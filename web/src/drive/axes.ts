/** Forward and left, −1…1. */
export interface Axes {
  linear: number;
  angular: number;
}

/** Of the head: left and up, −1…1. */
export interface HeadAxes {
  pan: number;
  tilt: number;
}
