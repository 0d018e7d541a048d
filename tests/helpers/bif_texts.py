"""Nets as other programs write them."""

CHILD = """
network child { }
variable CO2 { type discrete [ 3 ] { Normal, Low, High }; }
variable CO2Report { type discrete [ 2 ] { <7.5, >=7.5 }; }
variable Age { type discrete [ 3 ] { 0-3_days, 4-10_days, 11-30_days }; property a=b ; property cprm_unit="d" ; }
probability ( CO2 ) { table 0.8, 0.1, 0.1; }
probability ( CO2Report | CO2 ) { (Normal) 0.9, 0.1; (Low) 0.9, 0.1; (High) 0.1, 0.9; }
probability ( Age ) { table 0.1, 0.2, 0.7; }
"""

DOG = """
// Bayesian network
network "Dog-Problem" { //2 variables and 2 probability distributions
        property "credal-set constant-density-bounded 1.1" ;
}
variable  "light-on" { //2 values
        type discrete[2] {  "true"  "false" };
        property "position = (218, 195)" ;
}
variable  "family-out" { //2 values
        type discrete[2] {  "true"  "}" };
}
probability (  "light-on"  "family-out" ) { //2 variable(s) and 4 values
        table 0.6 0.05 0.4 0.95 ;
}
probability (  "family-out" ) { //1 variable(s) and 2 values
        table 0.15 0.85 ;
}
"""
