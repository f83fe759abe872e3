/** Forward and left, −1…1. */
export interface Axes {
  linear: number;
  angular: number;
}
