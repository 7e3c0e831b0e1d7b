/* Provides two features of Windows that Wine 8.0 lacks. Built as bcryptprimitives.dll, next to the
 * program.
 *
 * 1. ProcessPrng, which every Rust program imports from bcryptprimitives.dll.
 *
 * 2. One combination of a serial port's timeouts: ReadIntervalTimeout and ReadTotalTimeoutMultiplier
 *    both MAXDWORD, and ReadTotalTimeoutConstant between 0 and MAXDWORD. On Windows a read then
 *    returns as soon as there is any data. Wine 8.0 does not implement this and waits until the whole
 *    buffer is full, so that no answer is ever received. Here the call of the program, and of
 *    DobotDll.dll if that is loaded, is redirected to this file, which requests the nearest setting
 *    that Wine supports: a read ends 1 ms after the last received byte. All other settings of the port
 *    remain as requested by the program.
 */
#include <windows.h>

BOOLEAN WINAPI SystemFunction036(void *to, ULONG count);

__declspec(dllexport) BOOL WINAPI ProcessPrng(BYTE *to, SIZE_T count) {
    return SystemFunction036(to, (ULONG)count);
}

static BOOL WINAPI set_comm_timeouts(HANDLE port, COMMTIMEOUTS *wanted) {
    COMMTIMEOUTS known = *wanted;
    if (wanted->ReadIntervalTimeout == MAXDWORD && wanted->ReadTotalTimeoutMultiplier == MAXDWORD
        && wanted->ReadTotalTimeoutConstant > 0 && wanted->ReadTotalTimeoutConstant < MAXDWORD) {
        known.ReadIntervalTimeout = 1;
        known.ReadTotalTimeoutMultiplier = 0;
        known.ReadTotalTimeoutConstant = 0;
    }
    return SetCommTimeouts(port, &known);
}

/* Redirects a module's imports of `name`, from any library, to `instead`. */
static void lead(BYTE *program, const char *name, void *instead) {
    IMAGE_DOS_HEADER *dos = (IMAGE_DOS_HEADER *)program;
    IMAGE_NT_HEADERS *headers = (IMAGE_NT_HEADERS *)(program + dos->e_lfanew);
    DWORD place = headers->OptionalHeader.DataDirectory[IMAGE_DIRECTORY_ENTRY_IMPORT].VirtualAddress;
    IMAGE_IMPORT_DESCRIPTOR *library = (IMAGE_IMPORT_DESCRIPTOR *)(program + place);
    for (; place && library->Name; library++) {
        IMAGE_THUNK_DATA *names = (IMAGE_THUNK_DATA *)(program + library->OriginalFirstThunk);
        IMAGE_THUNK_DATA *calls = (IMAGE_THUNK_DATA *)(program + library->FirstThunk);
        for (; library->OriginalFirstThunk && names->u1.AddressOfData; names++, calls++) {
            DWORD before;
            if (IMAGE_SNAP_BY_ORDINAL(names->u1.Ordinal)
                || lstrcmpA(((IMAGE_IMPORT_BY_NAME *)(program + names->u1.AddressOfData))->Name, name) != 0
                || !VirtualProtect(calls, sizeof *calls, PAGE_READWRITE, &before)) {
                continue;
            }
            calls->u1.Function = (ULONG_PTR)instead;
            VirtualProtect(calls, sizeof *calls, before, &before);
        }
    }
}

BOOL WINAPI DllMain(HINSTANCE self, DWORD reason, void *reserved) {
    (void)self;
    (void)reserved;
    if (reason == DLL_PROCESS_ATTACH) {
        static const char *const callers[] = {NULL, "DobotDll.dll"};
        for (int at = 0; at < 2; at++) {
            BYTE *caller = (BYTE *)GetModuleHandleA(callers[at]);
            if (caller) {
                lead(caller, "SetCommTimeouts", (void *)set_comm_timeouts);
            }
        }
    }
    return TRUE;
}
