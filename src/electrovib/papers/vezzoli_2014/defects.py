"""What Vezzoli et al. 2014's own equations do not bear, told plainly."""

from __future__ import annotations

DEFECTS = (
    "Vezzoli 2014, prefactor: equation (1) divides the capacitor's energy by its geometric thickness. That is virtual work"
    " only for one homogeneous dielectric whose thickness changes; where finger and plate separate, the static force is"
    " (T_s + T_i)/K larger, 10.74 times on its film.",
    "Vezzoli 2014, discharge: conduction of the skin alone cannot discharge this film. The insulator holds 99.5 % of the"
    " voltage, so if the interface does not conduct the force under DC rises by (K/K_i)^2 = 1.0096 and stays. The decay to"
    " zero needs charge to cross the interface; the time constant of the skin then stands in the place of the leak's,"
    " eps0 rho_gap (1 + C_i/C_gap), which does not contain the skin.",
    "Vezzoli 2014, decay: it sets 7.7 ms calculated beside 6 ms measured in a lateral force. A force goes with the square of the"
    " voltage: if 7.7 ms is the time constant of the voltage, as in its equation (5), the force of the model decays in 3.85"
    " ms; if"
    " it is already the decay of the force, the voltage decays in 15.4 ms. In the same way its 2.5 mN are attraction and the"
    " measured"
    " 2 to 5 mN lateral force, which is less by the coefficient of friction.",
    "Vezzoli 2014, falling edges: equation (5) is linear and (6) even, so with one relaxation time and a long hold a"
    " symmetric trapezoidal pulse gives two equal pulses, while the measurement differs. With the dispersive causal"
    " skin the second"
    " is smaller, 0.66 to 0.93 for 25 ms ramps and holds of 20 to 200 ms, without new physics.",
    "Vezzoli 2014, dispersion: permittivity and resistivity at a frequency are put into a formula for a pulse without saying"
    " how. Read literally it answers before the pulse begins; it is kept for one sine at a time, beside a causal law.",
)
