#include "gas.h"

#include <math.h>

void gas_conserved(const double w[GAS_VALUES], double gamma, double u[GAS_VALUES]) {
  int a;
  double square = 0.0;
  for (a = 1; a < 4; ++a) {
    u[a] = w[0] * w[a];
    square += w[a] * w[a];
  }
  u[0] = w[0];
  u[4] = w[4] / (gamma - 1.0) + 0.5 * w[0] * square;
}

void gas_primitive(const double u[GAS_VALUES], double gamma, double w[GAS_VALUES]) {
  int a;
  double kinetic = 0.0;
  for (a = 1; a < 4; ++a) {
    w[a] = u[a] / u[0];
    kinetic += 0.5 * u[a] * w[a];
  }
  w[0] = u[0];
  w[4] = (gamma - 1.0) * (u[4] - kinetic);
}

double gas_sound_speed(const double w[GAS_VALUES], double gamma) {
  return sqrt(gamma * w[4] / w[0]);
}

/* The slowest and the fastest wave between two states: their own, or those of Roe's average. */
static void wave_speeds(const double l[GAS_VALUES], const double r[GAS_VALUES], int n, double gamma,
                        double* slowest, double* fastest) {
  const double cl = gas_sound_speed(l, gamma), cr = gas_sound_speed(r, gamma);
  const double wl = sqrt(l[0]), wr = sqrt(r[0]), sum = wl + wr;
  const double speed = (wl * l[n] + wr * r[n]) / sum, jump = r[n] - l[n];
  const double square =
      (wl * cl * cl + wr * cr * cr) / sum + 0.5 * (wl * wr) / (sum * sum) * (jump * jump);
  const double c = sqrt(square);
  *slowest = fmin(l[n] - cl, speed - c);
  *fastest = fmax(r[n] + cr, speed + c);
}

static void physical_flux(const double w[GAS_VALUES], const double u[GAS_VALUES], int n,
                          double flux[GAS_VALUES]) {
  int i;
  for (i = 0; i < GAS_VALUES; ++i)
    flux[i] = u[i] * w[n];
  flux[n] += w[4];
  flux[4] += w[4] * w[n];
}

/* HLLC (Toro, Spruce and Speares 1994), in the form whose mass and energy fluxes are exactly 0
 * where the contact stands still. */
void gas_flux(const double lower[GAS_VALUES], const double upper[GAS_VALUES], int axis,
              double gamma, double flux[GAS_VALUES]) {
  const int n = axis + 1;
  const double *l = lower, *r = upper;
  double sl, sr, contact, ml, mr, s, pressure;
  const double* w;
  double u[GAS_VALUES], f[GAS_VALUES];
  int i;
  wave_speeds(l, r, n, gamma, &sl, &sr);
  ml = l[0] * (sl - l[n]);
  mr = r[0] * (sr - r[n]);
  contact = ((r[4] - l[4]) + (l[n] * ml - r[n] * mr)) / (ml - mr);
  w = contact >= 0.0 ? l : r;
  s = contact >= 0.0 ? sl : sr;
  gas_conserved(w, gamma, u);
  physical_flux(w, u, n, f);
  if (sl >= 0.0 || sr <= 0.0) { /* all waves go one way, and the contact with them */
    for (i = 0; i < GAS_VALUES; ++i)
      flux[i] = f[i];
    return;
  }
  pressure = w[4] + (contact >= 0.0 ? ml : mr) * (contact - w[n]);
  for (i = 0; i < GAS_VALUES; ++i)
    flux[i] = contact * (s * u[i] - f[i]);
  flux[n] += s * pressure;
  flux[4] += s * pressure * contact;
  for (i = 0; i < GAS_VALUES; ++i)
    flux[i] /= s - contact;
}

/* HLL (Harten, Lax and van Leer 1983) with the same wave speeds. */
void gas_diffusive_flux(const double lower[GAS_VALUES], const double upper[GAS_VALUES], int axis,
                        double gamma, double flux[GAS_VALUES]) {
  double sl, sr, ul[GAS_VALUES], ur[GAS_VALUES], fl[GAS_VALUES], fr[GAS_VALUES];
  int i;
  wave_speeds(lower, upper, axis + 1, gamma, &sl, &sr);
  sl = fmin(sl, 0.0);
  sr = fmax(sr, 0.0);
  gas_conserved(lower, gamma, ul);
  gas_conserved(upper, gamma, ur);
  physical_flux(lower, ul, axis + 1, fl);
  physical_flux(upper, ur, axis + 1, fr);
  for (i = 0; i < GAS_VALUES; ++i)
    flux[i] = ((sr * fl[i] - sl * fr[i]) + sl * sr * (ur[i] - ul[i])) / (sr - sl);
}

void gas_wall_flux(const double w[GAS_VALUES], int axis, int outward, double gamma,
                   double flux[GAS_VALUES]) {
  double mirrored[GAS_VALUES];
  int i;
  for (i = 0; i < GAS_VALUES; ++i)
    mirrored[i] = i == axis + 1 ? -w[i] : w[i];
  if (outward > 0)
    gas_flux(w, mirrored, axis, gamma, flux);
  else
    gas_flux(mirrored, w, axis, gamma, flux);
}
