// A library with the name of HSL's, but without MA27, like a build of other HSL packages.
extern "C" {
int hsl_without_ma27() { return 0; }
}
