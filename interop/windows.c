/* Stands in for two things that Windows has and Wine 8.0 lacks. Built as bcryptprimitives.dll, beside the program.
 *
 * 1. ProcessPrng, which every Rust program imports from bcryptprimitives.dll.
 *
 * 2. The meaning of one setting of a serial port's time limits: ReadIntervalTimeout and ReadTotalTimeoutMultiplier both
 *    MAXDWORD, and ReadTotalTimeoutConstant between 0 and MAXDWORD. On Windows a read then ends with whatever has come
 *    as soon as anything has. Wine 8.0 knows no such thing and lets it wait until the whole buffer is full, so that no
 *    answer is ever seen. Here the call of the program, and of DobotDll.dll where that is loaded, is led past this file,
 *    which asks for the nearest that Wine knows instead: a read ends 1 ms after the last byte that came. Everything
 *    else about the port is as the program has it.
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

/* Has the imports of `name` that a program or library has, from whatever other, lead to `instead`. */
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
