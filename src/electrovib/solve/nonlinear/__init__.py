"""The general solver: one stiff system of charges, gap, contact and mechanics, implicit, with located events."""
