#include "measure/meeting.hpp"

namespace assur::measure {

bool Meeting::run(int calls) {
  for (int i = 0; i < calls; ++i) {
    team_.run([this](int) { team_.barrier(); });
  }
  return true;
}

}  // namespace assur::measure
