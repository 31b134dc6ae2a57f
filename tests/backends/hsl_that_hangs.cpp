// A library with the name of HSL's and all entries of MA27, whose first call never returns.
#include <unistd.h>

extern "C" {
void ma27id_(int*, double*) {
  for (;;) pause();
}
void ma27ad_() {}
void ma27bd_() {}
void ma27cd_() {}
}
