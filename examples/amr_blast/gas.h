/* An ideal gas. Primitive values w: density, velocity (3), pressure. Conserved ones u, per volume:
 * density, momentum (3), energy. Units are whatever the case chooses. */
#ifndef AMR_BLAST_GAS_H
#define AMR_BLAST_GAS_H

#ifdef __cplusplus
extern "C" {
#endif

enum { GAS_VALUES = 5 };

void gas_conserved(const double w[GAS_VALUES], double gamma, double u[GAS_VALUES]);
void gas_primitive(const double u[GAS_VALUES], double gamma, double w[GAS_VALUES]);
double gas_sound_speed(const double w[GAS_VALUES], double gamma);

/* What crosses a unit of area along an axis in a unit of time, from the state on the lower side to
 * the one on the upper side. */
void gas_flux(const double lower[GAS_VALUES], const double upper[GAS_VALUES], int axis,
              double gamma, double flux[GAS_VALUES]);

/* The same with more diffusion: contacts are smeared, and shocks along the grid stay straight. */
void gas_diffusive_flux(const double lower[GAS_VALUES], const double upper[GAS_VALUES], int axis,
                        double gamma, double flux[GAS_VALUES]);

/* The same at a wall that reflects: the state beyond is the mirrored one, so that neither mass nor
 * energy crosses. outward: 1 if the wall is at the state's upper side, -1 at its lower side. */
void gas_wall_flux(const double w[GAS_VALUES], int axis, int outward, double gamma,
                   double flux[GAS_VALUES]);

#ifdef __cplusplus
}
#endif

#endif
