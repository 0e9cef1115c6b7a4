#include <trisap.h>

int main(void) {
    const trisap_config config = trisap_default_config(2);
    return trisap_abi_version() == TRISAP_ABI_VERSION && trisap_world_size(&config) > 0 ? 0 : 1;
}
