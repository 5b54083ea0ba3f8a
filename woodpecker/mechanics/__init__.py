"""The equations of the toy: parameters, modes of motion, laws of impact; knows no map."""
