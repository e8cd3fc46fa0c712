/* Configuration of @app@. Change it here, or define it in the build of the mission. */
#ifndef @APP@_CFG_H
#define @APP@_CFG_H

@settings@
#endif
