"""Where the equations of Vezzoli et al. 2014 contradict each other, or the comparison that the paper makes."""

from __future__ import annotations

DEFECTS = (
    "Vezzoli 2014, prefactor: equation (1) divides the energy of the capacitor by its geometric thickness. That is virtual work"
    " only for one homogeneous dielectric whose thickness changes. Finger and plate separate in the gap, where the static force"
    " is larger by (T_s + T_i)/K, 10.74 times on its film.",
    "Vezzoli 2014, discharge: conduction of the skin alone cannot discharge this film. The insulator holds 99.5 % of the"
    " voltage, so if the interface does not conduct, the force under DC rises by (K/K_i)^2 = 1.0096 and stays. A decay to zero"
    " needs charge to cross the interface; its time constant is that of the leak, eps0 rho_gap (1 + C_i/C_gap), which does not"
    " contain the skin.",
    "Vezzoli 2014, decay: 7.7 ms calculated are compared with 6 ms measured in a lateral force. A force is proportional to the"
    " square of the voltage: if 7.7 ms is the time constant of the voltage, as in equation (5), the force of the model decays in"
    " 3.85 ms; if it is already the decay of the force, the voltage decays in 15.4 ms. Likewise its 2.5 mN are attraction, while"
    " the measured 2 to 5 mN are lateral force, which is smaller by the coefficient of friction.",
    "Vezzoli 2014, falling edges: equation (5) is linear and (6) even, so with one relaxation time and a long hold a symmetric"
    " trapezoidal pulse gives two equal pulses, while those measured differ. With the dispersive causal skin the second is"
    " smaller, 0.66 to 0.93 for ramps of 25 ms and holds of 20 to 200 ms, without further physics.",
    "Vezzoli 2014, dispersion: permittivity and resistivity at a frequency enter a formula for a pulse, and the paper does not"
    " state how. Taken literally, the formula responds before the pulse begins; it is used here for one sine at a time, beside a"
    " causal law.",
)
