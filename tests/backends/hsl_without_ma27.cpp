// A library by the name of HSL's, but without MA27, as one gets it with other packages chosen.
extern "C" {
int hsl_without_ma27() { return 0; }
}
