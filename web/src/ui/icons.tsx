/** Icons, drawn in the colour of the text around them. Decorative: the words are beside them or in labels. */

import type { ComponentChildren } from "preact";

function Icon({ children, fill = false }: { children: ComponentChildren; fill?: boolean }) {
  return (
    <svg
      class="icon"
      viewBox="0 0 24 24"
      aria-hidden="true"
      fill={fill ? "currentColor" : "none"}
      stroke={fill ? "none" : "currentColor"}
      stroke-width="2"
      stroke-linecap="round"
      stroke-linejoin="round"
    >
      {children}
    </svg>
  );
}

export const StopIcon = () => (
  <Icon fill>
    <path d="M8 2h8l6 6v8l-6 6H8l-6-6V8z" />
  </Icon>
);
/** Filled as far as it is charged; with a bolt while it is being charged. */
export const BatteryIcon = ({ charge, charging }: { charge: number; charging: boolean }) => (
  <Icon>
    <rect x="2" y="7" width="17" height="10" rx="2" />
    <path d="M22 11v2" />
    {charging ? (
      <path d="M11.5 5l-3.5 7h5l-3.5 7" />
    ) : (
      <rect
        x="4.5"
        y="9.5"
        width={12 * Math.min(1, Math.max(0, charge))}
        height="5"
        fill="currentColor"
        stroke="none"
      />
    )}
  </Icon>
);
export const WheelIcon = () => (
  <Icon>
    <circle cx="12" cy="12" r="9" />
    <circle cx="12" cy="12" r="2.5" />
    <path d="M3.5 10l6.2 1.2M20.5 10l-6.2 1.2M12 14.5V21" />
  </Icon>
);
export const KeyboardIcon = () => (
  <Icon>
    <rect x="2" y="6" width="20" height="12" rx="2" />
    <path d="M6 10h.01M10 10h.01M14 10h.01M18 10h.01M8 14h8" />
  </Icon>
);
export const CameraIcon = () => (
  <Icon>
    <path d="M3 8h4l2-3h6l2 3h4v11H3z" />
    <circle cx="12" cy="13" r="3.5" />
  </Icon>
);
export const CloseIcon = () => (
  <Icon>
    <path d="M6 6l12 12M18 6L6 18" />
  </Icon>
);
export const EnlargeIcon = () => (
  <Icon>
    <path d="M14 4h6v6M10 20H4v-6M20 4l-7 7M4 20l7-7" />
  </Icon>
);
export const ShrinkIcon = () => (
  <Icon>
    <path d="M20 10h-6V4M4 14h6v6M14 10l7-7M10 14l-7 7" />
  </Icon>
);
export const LockIcon = () => (
  <Icon>
    <rect x="5" y="11" width="14" height="9" rx="2" />
    <path d="M8 11V8a4 4 0 018 0v3" />
  </Icon>
);
export const PlusIcon = () => (
  <Icon>
    <path d="M12 5v14M5 12h14" />
  </Icon>
);
export const MinusIcon = () => (
  <Icon>
    <path d="M5 12h14" />
  </Icon>
);
export const PauseIcon = () => (
  <Icon fill>
    <path d="M6 5h4v14H6zM14 5h4v14h-4z" />
  </Icon>
);
export const PlayIcon = () => (
  <Icon fill>
    <path d="M7 4l13 8-13 8z" />
  </Icon>
);
export const TableIcon = () => (
  <Icon>
    <rect x="3" y="5" width="18" height="14" rx="1.5" />
    <path d="M3 10h18M9 10v9" />
  </Icon>
);
export const TrashIcon = () => (
  <Icon>
    <path d="M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13" />
  </Icon>
);
export const LinkIcon = () => (
  <Icon>
    <path d="M2 9a15 15 0 0120 0M5.5 12.5a10 10 0 0113 0M9 16a5 5 0 016 0" />
    <path d="M12 19.5h.01" />
  </Icon>
);
export const WarnIcon = () => (
  <Icon>
    <path d="M12 3l10 18H2zM12 10v5M12 18h.01" />
  </Icon>
);
export const ChevronIcon = () => (
  <Icon>
    <path d="M8 10l4 4 4-4" />
  </Icon>
);
export const LeftIcon = () => (
  <Icon>
    <path d="M19 12H5M11 6l-6 6 6 6" />
  </Icon>
);
export const ChevronUpIcon = () => (
  <Icon>
    <path d="M8 14l4-4 4 4" />
  </Icon>
);
export const TargetIcon = () => (
  <Icon>
    <circle cx="12" cy="12" r="8" />
    <circle cx="12" cy="12" r="3" />
    <path d="M12 1.5v4M12 18.5v4M1.5 12h4M18.5 12h4" />
  </Icon>
);
export const TourIcon = () => (
  <Icon>
    <path d="M6 20a2.5 2.5 0 110-5h11a3.5 3.5 0 000-7H9" />
    <circle cx="6.5" cy="8" r="2.5" />
    <circle cx="18.5" cy="20" r="1" fill="currentColor" />
  </Icon>
);
export const QrIcon = () => (
  <Icon>
    <path d="M4 4h6v6H4zM14 4h6v6h-6zM4 14h6v6H4zM14 14h3v3h-3zM20 14v.01M17 20v.01M20 17v3" />
  </Icon>
);

export const CubeIcon = () => (
  <Icon>
    <path d="M12 2.5l8.5 4.8v9.4L12 21.5l-8.5-4.8V7.3zM3.5 7.3L12 12l8.5-4.7M12 12v9.5" />
  </Icon>
);

export const StepIcon = () => (
  <Icon fill>
    <path d="M5 5l9 7-9 7zM16 5h3v14h-3z" />
  </Icon>
);
export const BackIcon = () => (
  <Icon fill>
    <path d="M19 5l-9 7 9 7zM5 5h3v14H5z" />
  </Icon>
);
export const ReplayIcon = () => (
  <Icon>
    <path d="M4 12a8 8 0 108-8 8 8 0 00-6 2.7L4 9M4 4v5h5" />
  </Icon>
);
export const FilmIcon = () => (
  <Icon>
    <rect x="3" y="4" width="18" height="16" rx="2" />
    <path d="M8 4v16M16 4v16M3 9h5M3 15h5M16 9h5M16 15h5" />
  </Icon>
);
export const RecordIcon = () => (
  <Icon fill>
    <circle cx="12" cy="12" r="7" />
  </Icon>
);
export const SquareIcon = () => (
  <Icon fill>
    <rect x="5.5" y="5.5" width="13" height="13" rx="2" />
  </Icon>
);
export const RingIcon = () => (
  <Icon>
    <path d="M20 12a8 8 0 11-2.6-5.9L20 8.5M20 4v4.5h-4.5" />
    <circle cx="12" cy="12" r="2.4" fill="currentColor" />
  </Icon>
);
export const DownloadIcon = () => (
  <Icon>
    <path d="M12 4v11M7 10.5l5 5 5-5M5 20h14" />
  </Icon>
);

export const AroundIcon = () => (
  <Icon>
    <path d="M2 7c6 2.5 14 2.5 20 0v10c-6-2.5-14-2.5-20 0z" />
    <circle cx="12" cy="12.2" r="1.6" fill="currentColor" />
  </Icon>
);
export const SalientIcon = () => (
  <Icon>
    <circle cx="12" cy="12" r="2.5" fill="currentColor" />
    <circle cx="12" cy="12" r="6.5" />
    <path d="M12 2v3M12 19v3M2 12h3M19 12h3" />
  </Icon>
);
export const HeadphonesIcon = () => (
  <Icon>
    <path d="M4 18v-5a8 8 0 0116 0v5" />
    <path d="M4 14h3v6H5.5A1.5 1.5 0 014 18.5zM20 14h-3v6h1.5a1.5 1.5 0 001.5-1.5z" />
  </Icon>
);
export const MicrophoneIcon = () => (
  <Icon>
    <rect x="9" y="3" width="6" height="11" rx="3" />
    <path d="M5.5 11a6.5 6.5 0 0013 0M12 17.5V21" />
  </Icon>
);
export const PersonIcon = () => (
  <Icon>
    <circle cx="12" cy="8" r="4" />
    <path d="M4.5 20.5a7.5 7.5 0 0115 0" />
  </Icon>
);
export const SoundIcon = () => (
  <Icon>
    <path d="M4 10v4h3.5l4.5 4V6L7.5 10zM15.5 9a4 4 0 010 6M18 6.5a8 8 0 010 11" />
  </Icon>
);

/** The state of a lane or a desire: distinguished by shape as well as colour. */
export function StateMark({ state }: { state: string }) {
  return (
    <svg class={`mark mark-${state}`} viewBox="0 0 12 12" aria-hidden="true">
      {state === "fulfilled" && <circle cx="6" cy="6" r="5" fill="currentColor" />}
      {state === "degraded" && (
        <>
          <circle cx="6" cy="6" r="4.3" fill="none" stroke="currentColor" stroke-width="1.4" />
          <path d="M6 1.7a4.3 4.3 0 010 8.6z" fill="currentColor" />
        </>
      )}
      {state === "unfulfilled" && (
        <path d="M2 2l8 8M10 2l-8 8" stroke="currentColor" stroke-width="2.4" stroke-linecap="round" />
      )}
      {state === "inhibited" && <path d="M2 6h8" stroke="currentColor" stroke-width="2.6" stroke-linecap="round" />}
      {state === "undesired" && <circle cx="6" cy="6" r="4" fill="none" stroke="currentColor" stroke-width="1.5" />}
      {state === "needed" && <path d="M6 .8L11.2 6 6 11.2.8 6z" fill="currentColor" />}
    </svg>
  );
}

export const MapIcon = () => (
  <Icon>
    <path d="M3 6.5l6-3 6 3 6-3v14l-6 3-6-3-6 3zM9 3.5v14M15 6.5v14" />
  </Icon>
);
export const FlagIcon = () => (
  <Icon>
    <path d="M6 21V4M6 5h11l-3 3.5 3 3.5H6" />
  </Icon>
);
export const HomeIcon = () => (
  <Icon>
    <path d="M3.5 11.5L12 4l8.5 7.5M6 10v9.5h12V10" />
  </Icon>
);
export const ExploreIcon = () => (
  <Icon>
    <circle cx="12" cy="12" r="8.5" />
    <path d="M15.5 8.5l-2 5-5 2 2-5z" />
  </Icon>
);
export const PlaceIcon = () => (
  <Icon>
    <path d="M12 3l6 16-6-4-6 4z" />
  </Icon>
);
export const SearchIcon = () => (
  <Icon>
    <circle cx="10.5" cy="10.5" r="6.5" />
    <path d="M15.5 15.5L21 21" />
  </Icon>
);
export const KeepOutIcon = () => (
  <Icon>
    <rect x="4" y="4" width="16" height="16" rx="1.5" />
    <path d="M4 13l9-9M4 19.5L19.5 4M11 20l9-9" />
  </Icon>
);
export const SlowIcon = () => (
  <Icon>
    <path d="M4 17a8.5 8.5 0 1116 0M12 17l-4-5.5" />
    <circle cx="12" cy="17" r="1.5" fill="currentColor" />
  </Icon>
);
export const FitIcon = () => (
  <Icon>
    <path d="M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5" />
  </Icon>
);
export const FollowIcon = () => (
  <Icon>
    <circle cx="12" cy="12" r="6.5" />
    <path d="M12 2.5v4M12 17.5v4M2.5 12h4M17.5 12h4" />
    <circle cx="12" cy="12" r="1.4" fill="currentColor" />
  </Icon>
);
export const CompassIcon = () => (
  <Icon>
    <circle cx="12" cy="12" r="9" />
    <path d="M12 6l3 6-3 6-3-6z" />
    <path d="M12 6l3 6H9z" fill="currentColor" />
  </Icon>
);
export const LayersIcon = () => (
  <Icon>
    <path d="M12 3.5l9 5-9 5-9-5zM3.5 13l8.5 4.8 8.5-4.8M3.5 17l8.5 4.8 8.5-4.8" />
  </Icon>
);
export const UndoIcon = () => (
  <Icon>
    <path d="M8 5L3.5 9.5 8 14M4 9.5h10a6 6 0 010 12h-3" />
  </Icon>
);
export const PencilIcon = () => (
  <Icon>
    <path d="M4 20l1-4L16.5 4.5l3 3L8 19zM14 7l3 3" />
  </Icon>
);
export const LayoutIcon = () => (
  <Icon>
    <rect x="3" y="4" width="18" height="16" rx="2" />
    <path d="M15 4v16M3 14h12" />
  </Icon>
);
export const SlidersIcon = () => (
  <Icon>
    <path d="M4 7h10M18 7h2M4 17h2M10 17h10" />
    <circle cx="16" cy="7" r="2" />
    <circle cx="8" cy="17" r="2" />
  </Icon>
);
export const SpeechIcon = () => (
  <Icon>
    <path d="M4 5h16v11H10l-4 4v-4H4z" />
  </Icon>
);

export const CompareIcon = () => (
  <Icon>
    <rect x="3" y="5" width="7.5" height="14" rx="1.5" />
    <rect x="13.5" y="5" width="7.5" height="14" rx="1.5" />
  </Icon>
);
